def report(files, _):
    return []
