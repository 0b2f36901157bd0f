line style: polygon
initial line width: 0.06 s
initial color: 100
viewpoint: 0,0,1
view reference point: 0,0,0
