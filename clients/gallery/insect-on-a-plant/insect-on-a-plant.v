line style: polygon
initial line width: 0.08 s
initial color: 40
