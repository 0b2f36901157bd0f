line style: cylinder
initial line width: 0.02 s
initial color: 40
viewpoint: 30,26,32
view reference point: 10,0,10
