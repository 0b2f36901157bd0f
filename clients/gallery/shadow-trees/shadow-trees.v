line style: cylinder
initial line width: 0.9 s
initial color: 40
viewpoint: 5,4,20
view reference point: 0,6,0
