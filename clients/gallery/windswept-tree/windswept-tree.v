angle increment: 45
line style: cylinder
initial line width: 0.16 s
initial color: 40
