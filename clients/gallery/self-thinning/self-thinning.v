line style: cylinder
initial line width: 0.02 s
initial color: 40
viewpoint: 12,9,14
view reference point: 5,0,5
