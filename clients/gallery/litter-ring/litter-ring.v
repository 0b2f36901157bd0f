line style: cylinder
initial line width: 0.05 s
initial color: 100
viewpoint: 0,-0.8,1
view reference point: 0,0,0
