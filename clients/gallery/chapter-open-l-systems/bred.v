angle increment: 20
line style: cylinder
initial line width: 0.8 s
initial color: 96
