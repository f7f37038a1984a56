#pragma once

#include <osg/Node>

#include <string>
#include <vector>

namespace midair::samples
{

/// Reads the files that PagedLODs and ProxyNodes at and below \a root name, level by level: a
/// viewer's pager does it as it draws, and here nothing is drawn. Reads at most kMostPagedFiles.
/// Returns sentences about what is not read.
std::vector<std::string> readPagedFiles(osg::Node& root);
constexpr int kMostPagedFiles = 256;

} // namespace midair::samples
