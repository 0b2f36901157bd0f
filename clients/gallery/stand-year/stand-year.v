line style: cylinder
initial line width: 0.01 s
initial color: 40
viewpoint: 5,2.5,6
view reference point: 0,0.6,0
