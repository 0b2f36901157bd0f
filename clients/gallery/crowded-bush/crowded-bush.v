line style: cylinder
initial line width: 0.04 s
initial color: 40
