line style: cylinder
initial line width: 0.06 s
initial color: 112
viewpoint: 2,2.2,5
