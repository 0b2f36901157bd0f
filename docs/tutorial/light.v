line style: cylinder
initial line width: 0.1 s
initial color: 40
