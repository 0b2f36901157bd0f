line style: cylinder
initial line width: 0.08 s
initial color: 40
viewpoint: 0,1,0
view reference point: 0,0,0
