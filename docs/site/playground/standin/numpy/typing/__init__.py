from .. import ndarray


class NDArray:
    def __class_getitem__(c, k):
        return ndarray


ArrayLike = object
