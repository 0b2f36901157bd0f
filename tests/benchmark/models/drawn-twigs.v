angle factor: 12
initial color: 2
initial line width: 0.02 units
line style: cylinder
contour sides: 8
