"""How well `gen refine` does on networks of motors of independent physics, of which something has been changed since.

``python -m benchmarks.network_refinement --cases 16x3 nothingx10 --fit-runs 2 --jobs 2 --json build/refinement.json``
prints the tables. Each motor (:mod:`benchmarks.plants`) is identified as a network from five steps and two mixed runs;
then something is changed (:mod:`benchmarks.plants.planted`), and later runs of 4 h refine the model and test it.
`--cases` takes KINDxN: the first 16 effects of the library, or all (`single`), on N motors; N motors with `nothing`
changed; N `pairs`; kinds `outside` of the library and undeclared `faults` on N motors; or any one by its name.

Errors are those of single samples against what the sensors read, in noise floors: the root mean square of read minus
what a perfect model of all that was changed says in the same samples. They are found anew from the refined model; what
`gen refine` says of them is only held against that.

``--case SEED:EFFECT:FIT --keep FOLDER`` leaves one trial's run files, models and figures, and the truth in
``truth.json``. ``--models FOLDER`` keeps identified networks for the next time: empty it when identification changes.
With ``--go-on`` an interrupted command, given again, takes what its ``--json`` has as judged.
"""
