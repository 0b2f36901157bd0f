executable: shadowpyramid -e shaded-maple.e shaded-maple.spec
turtle position: P: %.9g %.9g %.9g
