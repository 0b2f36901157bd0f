initial color: 96
initial line width: 0.2 s
