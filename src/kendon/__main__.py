"""``python -m kendon``: the command ``kendon``, for those who have it on no path."""

from kendon.cli import main

if __name__ == "__main__":
    main()
