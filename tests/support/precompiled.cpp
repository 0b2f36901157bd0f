// Compiled with the header that all test programs share; holds nothing of its own.
