"""movie.py DIR FIELD: a picture of each snapshot of a 2-D scene, or of the middle of a 3-D one, all with the
same colors, as DIR/movie_NNNN.png, and DIR/movie.gif.
kith run inputs/kelvin-helmholtz.yaml --set output.every=0.05 -o DIR"""
import numpy as np
import kith


def draw(directory, field="Density"):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.animation as animation
    import matplotlib.pyplot as plt
    run = kith.Run(directory)
    pictures = [(snapshot.time, *snapshot.slice(field, pixels=400)) for snapshot in run]
    low = min(np.nanmin(values) for _, values, _ in pictures)
    high = max(np.nanmax(values) for _, values, _ in pictures)
    figure, axes = plt.subplots(figsize=(6, 5), dpi=120)
    image = axes.imshow(pictures[0][1], origin="lower", extent=pictures[0][2], vmin=low, vmax=high)
    figure.colorbar(image, label=f"{field} (code units)")
    axes.set(xlabel="x (code units)", ylabel="y (code units)")

    def show(k):
        time, values, _ = pictures[k]
        image.set_data(values)
        axes.set_title(f"t = {time:.3f}")
        figure.savefig(f"{directory}/movie_{k:04d}.png")

    animation.FuncAnimation(figure, show, len(pictures)).save(f"{directory}/movie.gif",
                                                              animation.PillowWriter(fps=10))


kith.script(__doc__, draw)
