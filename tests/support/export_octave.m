% octave-cli export_octave.m FILE.mat OUT: what Octave reads, number by number as the hexadecimal digits of its bits, row by row, and texts as those of
% their bytes; a line TABLE COLUMN KIND ROWS WIDTH comes before the lines of each column.
arguments = argv();
data = load(arguments{1});
out = fopen(arguments{2}, "w");
for t = fieldnames(data)'
  table = data.(t{1});
  for c = fieldnames(table)'
    value = table.(c{1});
    fprintf(out, "%s %s %s %d %d\n", t{1}, c{1}, class(value), rows(value), columns(value));
    if iscell(value)
      for i = 1:numel(value)
        fprintf(out, "%s\n", sprintf("%02x", uint8(value{i})));
      end
    elseif ! isempty(value)
      assert(isa(value, "double") && isreal(value));
      fprintf(out, "%s\n", cellstr(num2hex(value'(:))){:});
    end
  end
end
fclose(out);
