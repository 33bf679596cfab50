"""Speed: the program's parts beside their peers and limits, measured in one go on one machine.

Times differ from machine to machine; the ratios of two that were taken one after the other hardly do. `measurement`
says how a time is taken and what a row of the table holds, `scenes` what is worked on; `runs`, `field`, `coulomb`,
`steps`, `reconstruction` and `start` are the parts, and `table` is all of them in order.
"""
