#pragma once
/// What launch files are broken with.
#include <string>
#include <vector>

namespace polyarm::ros_files {

inline const std::vector<std::string> kLaunchPieces{"<",
                                                    ">",
                                                    "/>",
                                                    "</group>",
                                                    "<group>",
                                                    "\"",
                                                    "'",
                                                    "$(",
                                                    ")",
                                                    "$(arg a)",
                                                    "$(eval ",
                                                    "$(eval a + a)",
                                                    "&amp;",
                                                    "&#x0;",
                                                    "<!--",
                                                    "<![CDATA[",
                                                    "]]>",
                                                    "<?xml?>",
                                                    "if=\"$(arg a)\"",
                                                    "<include file=\"main.launch\"/>",
                                                    "$(find x)",
                                                    "<arg name=\"a\" default=\"1\"/>",
                                                    "<rosparam>a: [</rosparam>",
                                                    "\xff",
                                                    std::string(1, '\0'),
                                                    "\n",
                                                    "//",
                                                    "~"};

}  // namespace polyarm::ros_files
