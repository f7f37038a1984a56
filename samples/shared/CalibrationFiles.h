#pragma once

#include "haptics/base/InputError.h"
#include "samples/shared/ScenesBelow.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticScene>

#include <osg/Matrixd>
#include <osgDB/WriteFile>

#include <fstream>
#include <iomanip>
#include <iostream>
#include <locale>
#include <string>
#include <vector>

namespace midair::samples
{

/// Writes \a worldToArray to a file, row by row. Throws base::InputError.
inline void writeMatrix(const std::string& path, const osg::Matrixd& worldToArray)
{
    std::ofstream out(path);
    out.imbue(std::locale::classic());
    out << "# the rows of an osg::Matrixd, as Calibration has them: array = world * M, metres\n"
        << std::setprecision(17);
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            out << worldToArray(row, column) << (column < 3 ? " " : "\n");
    out.flush();
    if (!out) throw base::InputError("can't write the matrix to \"" + path + "\"");
}

/// Copies the scene file \a from to \a to with \a worldToArray as the calibration of each
/// HapticScene. Throws base::InputError.
inline void
writeScene(const std::string& from, const std::string& to, const osg::Matrixd& worldToArray)
{
    const osg::ref_ptr<osg::Node> scene = osgMidair::readModel(from).getNode();
    if (!scene) throw base::InputError("can't read the scene \"" + from + "\"");
    const std::vector<osgMidair::HapticScene*> found = scenesBelow(*scene, false);
    for (osgMidair::HapticScene* one : found)
        one->setCalibration(worldToArray);
    if (found.empty())
        throw base::InputError("there is no osgMidair::HapticScene in \"" + from +
                               "\" to hold a calibration");
    if (!osgDB::writeNodeFile(*scene, to))
        throw base::InputError("can't write the scene to \"" + to + "\"");
    std::cout << "calibration written into " << found.size() << " HapticScene of " << to << "\n";
}

} // namespace midair::samples
