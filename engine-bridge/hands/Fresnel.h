#pragma once

#include <complex>

namespace midair::bridge
{

/// The field behind the edge of a half-plane divided by the field without it: F(v) = (1 + j)/2
/// integral from v to infinity of e^{-j pi t^2/2} dt (Fresnel-Kirchhoff; ITU-R P.526, equation 7b).
/// v is the height of the edge over the straight path in units of the first Fresnel zone's
/// sqrt(lambda d1 d2/(2 (d1 + d2))): F is 1 at -infinity, 1/2 at 0, 0 at infinity. Good to 2e-3,
/// the error of the rational approximations in Abramowitz & Stegun, 7.3.32 and 7.3.33.
std::complex<double> knifeEdge(double v);

/// The share 0 .. 1 of the amplitude that passes a rectangle from x1 to x2 across and from y1 to y2
/// along, all in units of v: |1 - (F(x1) - F(x2)) (F(y1) - F(y2))|, by Babinet's principle. x1 >
/// -x2 (the nearer edge is x1). Leaves out the ripples of a few percent outside the shadow: returns
/// 1 from x1 = kLit on.
double pastRectangle(double x1, double x2, double y1, double y2);

/// An edge this far off the straight path, in units of v, takes nothing away (|1 - F(v)| is first 1
/// at 0.6).
constexpr double kLit = 0.8;

} // namespace midair::bridge
