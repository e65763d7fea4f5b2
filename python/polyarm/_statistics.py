"""Statistics of the features of a data set, as LeRobot has them in meta/stats.json."""
import numpy as np


def statistics(values):
    """Of one feature, as LeRobot has them: lists of one number for each dimension."""
    array = np.asarray(values, float).reshape(len(values), -1)
    out = {"min": array.min(0), "max": array.max(0), "mean": array.mean(0), "std": array.std(0),
           "count": np.array([len(array)])}
    for name, share in (("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)):
        out[name] = np.quantile(array, share, axis=0)
    return out


def image_statistics(images):
    """Of pictures: each channel as 3 x 1 x 1, from 0 to 1, of at most 100 pictures."""
    chosen = np.linspace(0, len(images) - 1, min(len(images), 100)).round().astype(int)
    array = np.stack([images[i][::4, ::4].reshape(-1, 3).astype(float) / 255 for i in chosen])
    stats = statistics(array.reshape(-1, 3))
    return {name: value.reshape(-1, 1, 1) if name != "count" else np.array([len(chosen)])
            for name, value in stats.items()}


def together(all_stats):
    """Statistics of several episodes as one."""
    count = np.array([float(stats["count"][0]) for stats in all_stats])
    weight = count / count.sum()

    def mixed(name):
        return sum(w * np.asarray(stats[name]) for w, stats in zip(weight, all_stats))

    mean = mixed("mean")
    spread = sum(w * (np.asarray(s["std"]) ** 2 + (np.asarray(s["mean"]) - mean) ** 2) for w, s in zip(weight, all_stats))
    out = {"min": np.min([s["min"] for s in all_stats], axis=0), "max": np.max([s["max"] for s in all_stats], axis=0),
           "mean": mean, "std": np.sqrt(spread), "count": np.array([int(count.sum())])}
    return out | {name: mixed(name) for name in all_stats[0] if name.startswith("q")}
