angle increment: 60
twist: 900
line style: cylinder
initial line width: 0.4 s
initial color: 200
