"""The modified Phong model (Lewis 1993) as a BSDF plugin `phong` of Mitsuba 3, whose own plugins lack it.

f_r = kd/pi + ks (n+2)/(2 pi) max(0, cos a)^n with a the angle between `wo` and the mirror of `wi`; properties as in
Mitsuba 0.6. One-sided: the scenes wrap it in `twosided`. Import it after a variant is set.
"""

import drjit as dr
import mitsuba as mi


class ModifiedPhong(mi.BSDF):
    def __init__(self, properties):
        super().__init__(properties)
        self.diffuse = properties.get_texture("diffuse_reflectance", 0.5)
        self.specular = properties.get_texture("specular_reflectance", 0.2)
        self.exponent = float(properties.get("exponent", 30.0))
        kd, ks = (float(dr.mean(texture.mean())[0]) for texture in (self.diffuse, self.specular))
        self.share = kd / max(kd + ks, 1e-9)  # of the samples that the diffuse part gets
        front = mi.BSDFFlags.FrontSide
        self.m_components = [mi.BSDFFlags.GlossyReflection | front, mi.BSDFFlags.DiffuseReflection | front]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def lobe(self, si, wo):
        cosine = dr.maximum(dr.dot(mi.reflect(si.wi), wo), 0.0)
        return dr.power(cosine, self.exponent)

    def both_above(self, si, wo):
        return (mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)

    def eval(self, context, si, wo, active=True):
        n = self.exponent
        value = self.diffuse.eval(si, active) * dr.inv_pi
        value += self.specular.eval(si, active) * (self.lobe(si, wo) * ((n + 2) * 0.5 * dr.inv_pi))
        return dr.select(active & self.both_above(si, wo), value * mi.Frame3f.cos_theta(wo), 0.0)

    def pdf(self, context, si, wo, active=True):
        n = self.exponent
        density = self.share * mi.warp.square_to_cosine_hemisphere_pdf(wo)
        density += (1 - self.share) * (self.lobe(si, wo) * ((n + 1) * 0.5 * dr.inv_pi))
        return dr.select(active & self.both_above(si, wo), density, 0.0)

    def sample(self, context, si, sample1, sample2, active=True):
        diffuse = sample1 < self.share
        cosine = dr.power(sample2.x, 1 / (self.exponent + 1))
        sine = dr.safe_sqrt(1 - cosine * cosine)
        s, c = dr.sincos(2 * dr.pi * sample2.y)
        about_mirror = mi.Frame3f(mi.reflect(si.wi)).to_world(mi.Vector3f(sine * c, sine * s, cosine))
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(diffuse, mi.warp.square_to_cosine_hemisphere(sample2), about_mirror)
        bs.eta = 1.0
        bs.sampled_type = dr.select(diffuse, +mi.BSDFFlags.DiffuseReflection, +mi.BSDFFlags.GlossyReflection)
        bs.sampled_component = dr.select(diffuse, mi.UInt32(1), mi.UInt32(0))
        bs.pdf = self.pdf(context, si, bs.wo, active)
        good = active & (bs.pdf > 0)
        return bs, dr.select(good, self.eval(context, si, bs.wo, active) / bs.pdf, 0.0)

    def eval_diffuse_reflectance(self, si, active=True):
        return self.diffuse.eval(si, active) + self.specular.eval(si, active)

    def traverse(self, callback):
        callback.put("diffuse_reflectance", self.diffuse, mi.ParamFlags.Differentiable)
        callback.put("specular_reflectance", self.specular, mi.ParamFlags.Differentiable)

    def to_string(self):
        return f"ModifiedPhong[exponent={self.exponent}]"


mi.register_bsdf("phong", ModifiedPhong)
