viewpoint: 6,1.7,0.8
view reference point: 0,1.6,0
initial color: 96
line style: cylinder
