executable: multiple -e root-and-shoot.e root-and-shoot.spec
