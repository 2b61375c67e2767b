"""``python -m passafe_services.cli``: the same as the console script ``passafe``."""

from passafe_services.cli.app import main

if __name__ == "__main__":
    main()
