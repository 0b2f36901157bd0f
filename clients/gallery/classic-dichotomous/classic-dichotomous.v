angle increment: 28
line style: cylinder
initial line width: 0.15 s
initial color: 96
