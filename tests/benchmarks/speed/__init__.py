"""Speed: the parts of the program beside other methods and lower bounds, measured on one machine.

Times differ between machines; ratios of two times taken in turn hardly do. `measurement` takes times and defines a row
of the table, `scenes` makes the inputs; `runs`, `field`, `steps` and `start` are the parts, and `table` is all of
them in order. `growth` is the other table: time and memory as the work grows.
"""
