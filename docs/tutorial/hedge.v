line style: cylinder
initial line width: 0.06 s
initial color: 96
