line style: cylinder
initial line width: 0.4 s
initial color: 40
viewpoint: 3,2,8
view reference point: 0,3,0
