line style: cylinder
initial line width: 0.05 s
initial color: 40
viewpoint: 22,14,28
view reference point: 10,0,10
