#include "haptics/scattering/SceneScattering.h"

#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

ScatteringFigures scatteringOf(ScatteredField& truth,
                               const std::vector<Eigen::Matrix3Xd>& points,
                               const std::vector<Eigen::VectorXcf>& fields)
{
    for (const Eigen::Matrix3Xd& of : points)
        if (const std::string why = truth.whyImpossible(of); !why.empty())
            throw base::InputError(why);
    ScatteringFigures figures;
    double off2 = 0.0, free2 = 0.0, with2 = 0.0, count = 0.0;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        truth.setDrive(fields[k]);
        figures.free_Pa.emplace_back(truth.free_Pa(points[k]));
        const Eigen::VectorXcd& alone = figures.free_Pa.back();
        figures.with_Pa.emplace_back(alone + truth.scattered_Pa(points[k]));
        for (Eigen::Index l = 0; l < alone.size(); ++l)
        {
            const double was = std::abs(alone[l]), is = std::abs(figures.with_Pa.back()[l]);
            if (!(was > 0.0)) continue;
            off2 += (is / was - 1.0) * (is / was - 1.0);
            figures.worst = std::max(figures.worst, std::abs(is / was - 1.0));
            free2 += was * was;
            with2 += is * is;
            count += 1.0;
        }
    }
    figures.elements = truth.elements();
    figures.iterations = truth.worst().iterations;
    figures.residual = truth.worst().residual;
    if (count == 0.0) return figures;
    figures.rms = std::sqrt(off2 / count);
    figures.level = std::sqrt(with2 / free2);
    return figures;
}

} // namespace midair::haptics
