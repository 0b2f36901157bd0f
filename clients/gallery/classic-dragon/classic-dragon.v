angle increment: 90
line style: cylinder
initial line width: 0.2 s
initial color: 160
