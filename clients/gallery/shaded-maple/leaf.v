initial line width: 0.1 s
initial color: 2
contour sides: 12
contour: 1 petiole.con
viewpoint: 0.3,0.2,1
view reference point: 0,0,0
