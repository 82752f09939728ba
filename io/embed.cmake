# Writes OUTPUT, a C++ source whose io::NAME is the text of INPUT. Strings are cut into pieces because the standard promises no
# more than 64 KiB for one literal.
file(READ ${INPUT} text)
string(LENGTH "${text}" length)
get_filename_component(file ${INPUT} NAME)
set(source "// Made from material/${file}.\nnamespace io {\nextern const char* const ${NAME};\nconst char* const ${NAME} =\n")
set(first 0)
while(first LESS length)
  string(SUBSTRING "${text}" ${first} 8000 piece)
  string(APPEND source "R\"library(${piece})library\"\n")
  math(EXPR first "${first} + 8000")
endwhile()
string(APPEND source "\"\";\n}  // namespace io\n")
file(WRITE ${OUTPUT} "${source}")
