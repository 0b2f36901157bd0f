angle increment: 60
line style: cylinder
initial line width: 0.2 s
initial color: 160
