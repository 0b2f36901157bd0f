angle increment: 22.5
line style: cylinder
initial line width: 0.35 s
initial color: 96
