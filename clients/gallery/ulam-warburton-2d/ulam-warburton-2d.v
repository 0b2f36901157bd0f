angle increment: 90
line style: cylinder
initial line width: 0.3 s
initial color: 96
viewpoint: 0,1,0
view reference point: 0,0,0
