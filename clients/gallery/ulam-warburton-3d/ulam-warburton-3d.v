angle increment: 90
line style: cylinder
initial line width: 0.2 s
initial color: 96
viewpoint: 2,1,3
view reference point: 0,0,0
