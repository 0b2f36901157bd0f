executable: height
turtle position: P: %.9g %.9g %.9g
