angle increment: 45
line style: cylinder
initial line width: 0.12 s
