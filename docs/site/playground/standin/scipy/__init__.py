import sys, types, importlib.machinery, importlib.abc


class _M(types.ModuleType):
    def __getattr__(s, a):
        if a == "null_space":

            def null_space(A, rcond=None):
                import numpy as np

                w, v = np.linalg.eigh(A.T @ A)
                k = [i for i, x in enumerate(w.f) if x <= 1e-14 * max(1e-300, *w.f)]
                return v[:, k] if k else np.zeros((A.shape[1], 0))

            return null_space
        if a.startswith("__"):
            raise AttributeError(a)

        class Missing:
            def __init__(self, *x, **k):
                raise RuntimeError("called " + s.__name__ + "." + a)

            def __class_getitem__(c, k):
                return c

        Missing.__name__ = a
        return Missing


class _F(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(s, n, p, t=None):
        if n.startswith("scipy."):
            return importlib.machinery.ModuleSpec(n, s, is_package=True)

    def create_module(s, spec):
        return _M(spec.name)

    def exec_module(s, m):
        m.__path__ = []


sys.meta_path.insert(0, _F())
