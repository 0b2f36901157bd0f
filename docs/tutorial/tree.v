line style: cylinder
initial color: 40
viewpoint: 1,0.5,3
view reference point: 0,2,0
