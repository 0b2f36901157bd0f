angle increment: 25.7
line style: cylinder
initial line width: 0.5 s
initial color: 96
