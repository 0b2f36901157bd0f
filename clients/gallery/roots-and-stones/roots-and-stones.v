line style: polygon
initial line width: 0.03 s
initial color: 100
