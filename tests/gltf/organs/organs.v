line style: cylinder
initial line width: 0.2 s
contour sides: 10
surface: l leaf.s 1
