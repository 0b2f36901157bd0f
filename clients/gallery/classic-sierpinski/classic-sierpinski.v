angle increment: 60
line style: cylinder
initial line width: 0.3 s
initial color: 136
