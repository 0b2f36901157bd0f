line style: cylinder
initial line width: 0.05 s
initial color: 40
