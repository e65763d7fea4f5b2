// Has nothing in it: the headers that cmake/precompiled.cmake lists are compiled with it, once.
