line style: cylinder
initial line width: 0.09 s
initial color: 40
