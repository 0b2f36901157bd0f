line style: cylinder
initial line width: 0.003 s
viewpoint: 1,0.9,1.2
view reference point: 0,0.15,0
