executable: shadowpyramid -e shadow-trees.e shadow-trees.spec
turtle position: P: %.9g %.9g %.9g
