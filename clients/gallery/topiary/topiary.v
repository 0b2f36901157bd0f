line style: cylinder
initial line width: 0.12 s
initial color: 112
