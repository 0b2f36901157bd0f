angle increment: 25
line style: cylinder
initial line width: 0.12 s
initial color: 96
viewpoint: 0,0,1
view reference point: 0,0,0
