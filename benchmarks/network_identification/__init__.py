"""How well `gen identify` does on motors of independent physics: networks that share no line with it.

``python -m benchmarks.network_identification --plants 100 --model both --jobs 2 --json build/network.json`` prints the
table. Each plant is identified from four kinds of data in three kinds of rooms (:mod:`benchmarks.plants.cases`), and
its model predicts two runs of 4 h that took no part. Errors are those of single samples against what the sensors read,
in noise floors: the root mean square of read minus true in the same samples. So 1 is a perfect model of the
temperatures, and a little less one that knows the sensors' biases, too.

``--case SEED:DATA:ROOM --keep FOLDER`` leaves one case's run files, model and figures to look at, and in
``plant.json`` the truth.
"""
