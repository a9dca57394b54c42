def draw(path):
    return {}
