line style: cylinder
initial line width: 0.1 s
initial color: 40
viewpoint: 1,0.5,3
view reference point: 0,2,0
