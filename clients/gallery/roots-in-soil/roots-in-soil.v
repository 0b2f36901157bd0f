line style: polygon
initial line width: 0.01 s
initial color: 100
