line style: cylinder
initial line width: 1.6 s
initial color: 96
viewpoint: 0,3,2
view reference point: 0,30,0
