angle increment: 90
line style: cylinder
initial line width: 0.3 s
initial color: 200
